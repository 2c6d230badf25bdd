"""The simulated workbench: RGB-D frames of a scripted assembly, with ground truth."""
