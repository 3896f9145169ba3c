"""What is said of an identified network: uncertainty, forecasts, the coefficient file, the summary and the page."""
