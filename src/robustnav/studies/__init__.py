"""The published studies, rebuilt and judged."""
