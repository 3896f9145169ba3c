"""What the templates are told, a module for each group of them; the keys are the names that the templates use."""
