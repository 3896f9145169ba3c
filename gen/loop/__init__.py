"""From measured runs to models: identification. It reads run files and coefficient files, nothing else."""
