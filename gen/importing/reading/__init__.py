"""What is in a file, as a table: text in every dialect, workbooks, and files that hold types."""
