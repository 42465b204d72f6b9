"""Truth and sensors from nothing: trajectories, sensor error models, data-sheet presets."""
