"""The published batch estimate of the arm's seven unknowns, which `armukf simulate` takes."""

TRUTH = {"a_m": 0.266479, "a_g": 0.647533, "k_g1": 20.0774, "k_g3": 24.178,
         "d_g": 0.030513, "k_a": 11.7552, "d_a": 0.00283465}
