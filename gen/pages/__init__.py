"""What HTML pages are made of: charts and the environment of their templates."""
