"""A self-contained C99 tree from a model and a filter, for firmware."""
