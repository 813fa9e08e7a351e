"""ToR-ORd membrane of 2019: human ventricle, 42 states; split by subject."""

from myostrain.membranes.to_ror_d_2019.model import ToRORd2019

__all__ = ["ToRORd2019"]
