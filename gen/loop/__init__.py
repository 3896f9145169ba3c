"""From measured runs to models: identification and refinement. It reads run files and coefficient files, nothing else."""
