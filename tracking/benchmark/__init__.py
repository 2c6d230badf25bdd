"""The benchmark: methods over sequences with known truth, by the paper's measures and strict ones."""
