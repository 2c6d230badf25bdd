"""Finding parts in one image: ONNX Runtime, decoding, PnP (GBOT, section 3.1).

Nothing is imported here: ONNX Runtime is loaded by who makes a detector.
"""
