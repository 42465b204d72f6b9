"""Where anchors stand, from ranges between them and to a moving tag."""
