"""From measured runs to models: it reads run files and coefficient files, nothing else."""
