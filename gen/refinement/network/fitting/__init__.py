"""A file's network with everything free within what is known of it, and effects, fitted to later runs."""
