"""Where frames come from: recorded sequences, BOP scenes, the simulated workbench."""
