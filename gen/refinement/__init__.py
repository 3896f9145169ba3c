"""Refinement: from a baseline and measured runs to the effects that it lacks. It reads run and coefficient files only.

Runs are condensed along the baseline (`condense`) and admitted (`admission`); effects are traced part by part (`parts`)
or as terms of a network (`network`); what is gained must be more than chance (`gains`), and what comes of it is said
(`verdict`, `worse`) from the errors of all runs (`run_errors`).
"""
