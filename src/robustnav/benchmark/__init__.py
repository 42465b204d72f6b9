"""Accuracy on public recordings and speed, each beside the peer libraries that are installed."""
