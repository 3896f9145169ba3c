"""What a document must satisfy before anything is built from it, beyond its form."""
