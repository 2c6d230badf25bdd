"""The keypoint network: YOLOv8-pose's design, its training, and what is written beside it.

Nothing is imported here: `card` is read by the tracking, which has no PyTorch; the rest needs the
extra `train`.
"""
