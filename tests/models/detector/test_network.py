"""The network's shape, and its ONNX file, which must say the same as the network."""

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="PyTorch is not installed: snapfit[train]")
onnx = pytest.importorskip("onnx", reason="onnx is not installed: snapfit[train]")

from snapfit.models.detector.export import export_onnx
from snapfit.models.detector.network import PoseNetwork, anchor_grid
from snapfit.models.detector.onnx_graph import OPSET
from snapfit.models.detector.quantise import last_nodes, write_int8
from snapfit.models.detector.recipe import LEAN
from snapfit.models.detector.size import YOLOV8N, NetworkSize

SMALL = NetworkSize(width=0.0625, box_channels=16, class_channels=16, keypoint_channels=16)


def small_network(n_classes=3, n_keypoints=5):
    torch.manual_seed(1)
    network = PoseNetwork(SMALL, n_classes, n_keypoints)
    # Statistics that are not the first ones, so that folding them is put to the test.
    for each in network.modules():
        if isinstance(each, torch.nn.BatchNorm2d):
            each.running_mean.uniform_(-0.2, 0.2)
            each.running_var.uniform_(0.5, 2.0)
            torch.nn.init.uniform_(each.weight, 0.5, 1.5)
    return network.eval()


def test_the_public_size_has_as_many_parameters_as_the_public_network():
    """YOLOv8n-pose: 3,295,470, of which 16 are the fixed bins of the distribution."""
    network = PoseNetwork(YOLOV8N, 1, 17)
    assert sum(each.numel() for each in network.parameters()) == 3_295_470 - 16
    assert YOLOV8N.channels == (16, 32, 64, 128, 256)
    assert YOLOV8N.repeats == (1, 2, 2, 1)


def test_the_lean_one_fits_a_bundle():
    network = PoseNetwork(LEAN, 8, 17)
    assert 2 * sum(each.numel() for each in network.parameters()) < 12e6


@pytest.mark.parametrize("value", [0, -1, float("nan")])
def test_a_size_is_positive(value):
    with pytest.raises(ValueError, match="width"):
        NetworkSize(width=value)


def test_every_anchor_says_something():
    raw = small_network()(torch.rand(2, 3, 64, 96))
    n_anchors = 8 * 12 + 4 * 6 + 2 * 3
    assert raw.boxes().shape == (2, n_anchors, 4)
    assert raw.classes.shape == (2, n_anchors, 3)
    assert raw.points().shape == (2, n_anchors, 5, 2)
    image, anchor = torch.tensor([0, 1]), torch.tensor([3, 40])
    assert torch.equal(raw.points_at(image, anchor), raw.points()[image, anchor])


def test_anchors_are_the_middles_of_their_cells():
    anchors, strides = anchor_grid([(2, 3), (1, 2), (1, 1)], torch.device("cpu"))
    assert anchors[:3].tolist() == [[4, 4], [12, 4], [20, 4]]
    assert anchors[6:].tolist() == [[8, 8], [24, 8], [16, 16]]
    assert strides.tolist() == [8] * 6 + [16] * 2 + [32]


def outputs(path, images):
    import onnxruntime

    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    return session.run(None, {"images": images.numpy()})[0]


def public_layout(raw):
    boxes = raw.boxes()
    near, far = boxes.split(2, dim=-1)
    keypoints = torch.cat([raw.points(), raw.keypoints[..., 2:].sigmoid()], dim=-1)
    rows = [(near + far) / 2, far - near, raw.classes.sigmoid(), keypoints.flatten(2)]
    return torch.cat(rows, dim=-1).transpose(1, 2).detach().numpy()


@pytest.mark.parametrize("shape", [(1, 64, 96), (2, 96, 64)])
def test_the_file_says_what_the_network_says_at_any_size(tmp_path, shape):
    network = small_network()
    export_onnx(network, tmp_path / "d.onnx", halves_weights=False, metadata={"asset": "x"})
    images = torch.rand(shape[0], 3, *shape[1:])
    np.testing.assert_allclose(
        outputs(tmp_path / "d.onnx", images), public_layout(network(images)), atol=2e-3
    )
    model = onnx.load(tmp_path / "d.onnx")
    assert model.opset_import[0].version == OPSET
    assert {each.key: each.value for each in model.metadata_props} == {"asset": "x"}


def test_halved_weights_halve_the_file_and_change_little(tmp_path):
    network = small_network()
    export_onnx(network, tmp_path / "single.onnx", halves_weights=False)
    export_onnx(network, tmp_path / "half.onnx")
    sizes = [(tmp_path / name).stat().st_size for name in ("single.onnx", "half.onnx")]
    assert sizes[1] < 0.65 * sizes[0]
    images = torch.rand(1, 3, 64, 96)
    single, half = (outputs(tmp_path / name, images) for name in ("single.onnx", "half.onnx"))
    assert 0 < np.abs(single - half).max() < 0.3


def test_eight_bits_leave_the_last_layers_alone(tmp_path):
    network = small_network()
    blobs = [np.random.default_rng(i).random((1, 3, 64, 96), dtype=np.float32) for i in range(4)]
    write_int8(network, tmp_path / "int8.onnx", blobs)
    export_onnx(network, tmp_path / "single.onnx", halves_weights=False)
    kept = last_nodes(onnx.load(tmp_path / "single.onnx"))
    assert "output0" in kept
    model = onnx.load(tmp_path / "int8.onnx")
    weights = {each.name: each.data_type for each in model.graph.initializer}
    convolutions = [node for node in model.graph.node if node.op_type == "Conv"]
    plain = [node.name for node in convolutions if node.input[1] in weights]
    assert sorted(plain) == sorted(name for name in kept if name.startswith("conv"))
    assert len(plain) == 9
    assert len(convolutions) > 50
    single = public_layout(network(torch.from_numpy(blobs[0])))
    difference = np.abs(outputs(tmp_path / "int8.onnx", torch.from_numpy(blobs[0])) - single)
    assert np.median(difference[:4]) < 2.0


def test_a_layer_without_a_rule_is_refused(tmp_path):
    network = small_network()
    network.to_8 = torch.nn.Sequential(torch.nn.Tanh())
    with pytest.raises(TypeError, match="Tanh"):
        export_onnx(network, tmp_path / "d.onnx")
