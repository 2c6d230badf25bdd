"""The per-frame work: sources, modalities, optimiser, tracker."""
