"""Initial alignment of a strapdown unit on a swaying, disturbed carrier."""
