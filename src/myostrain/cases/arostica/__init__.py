"""Displacements that teams found for the benchmark of elastodynamics, one file per case (docs/arostica.md).

Source: R. Aróstica and others, Comput. Methods Appl. Mech. Eng. 435 (2025) 117485, doi
10.1016/j.cma.2024.117485; data of the authors' toolkit github.com/Reidmen/cardiac_benchmark_toolkit (MIT
license), sampled every 0.01 s.
"""
