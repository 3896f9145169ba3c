"""A motor that runs, as a local web page: what its board prints, beside the model, and commands to it."""
