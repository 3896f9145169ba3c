"""Small defects planted into `gen/` and `templates/`, one at a time: do the nearest tests see them?"""
