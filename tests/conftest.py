"""Settings of the whole suite: the same examples on every run, so that a failure can be repeated."""

from hypothesis import settings

settings.register_profile("steady", derandomize=True, deadline=None, database=None)
settings.load_profile("steady")
