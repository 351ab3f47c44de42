"""What `scripts/validate` measures: a module for each section, whose `tables(options)` are its tables."""
