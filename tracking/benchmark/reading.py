"""How to read the benchmark's report: printed below its tables."""

from snapfit.tracking.benchmark.losses import LOST_FRAMES
from snapfit.tracking.benchmark.states import NEAR_FRAMES
from snapfit.tracking.benchmark.tables import TOLD
from snapfit.tracking.metrics import MOST_VERTICES

READING = f"""\
Every run starts from the true poses of its first frame, which counts as any other; a method \
whose name ends in `-cold` is given no pose, and the frames before its first find count too. Who \
is given no pose, or remembers nothing of it, cannot tell parts of one mesh apart: its estimates \
count for those of them that they are nearest to, frame by frame, as BOP does. What a detector \
beside the tracker finds comes as many frames later as its declared latency lasts; its own time \
is in that of the frame in which it looks, though live it would look in a thread of its own. A \
frame without an estimate is a failure: beyond every threshold, 10 cm in e_trans, 180 degrees in \
e_rot, infinite in medians. ADD is taken of parts without symmetry, ADD-S of symmetric ones, as \
the mean over the mesh's vertices (of more than {MOST_VERTICES} a fixed sample of \
{MOST_VERTICES}, seed 0); MSSD and MSPD go over all vertices. A row is the mean over all parts \
and frames of a sequence; means are over such rows, every sequence weighing the same. *Overall* \
is the paper's four conditions: normal, dynamic, hand and blur; `all`, everything at once, stands \
apart. The score at 10 cm flatters everybody: read it together with the strict figures.

- **As in the paper. ADD(-S)**: score at 10 cm, mean of max(1 - e / 10 cm, 0), %; **< 10 cm**: \
frames under 10 cm, %; **e_trans**: cm; **e_rot**: degrees, parts without symmetry; **ms**: \
tracking of a frame with all its parts by the clock, mean, decoding left out.
- **Strict. < 0.1 d**: frames whose ADD(-S) is under 10 % of the part's diameter, %; \
**AUC 2 cm**: area under the curve of ADD(-S) up to 2 cm, %; **AR MSSD**, **AR MSPD**: BOP's \
average recalls, %; **MSSD**, **MSPD**: medians, mm and px; **lost**: frames without an estimate, \
%; **CPU ms**: time of a core that tracking a frame takes, all threads added up.
- **Speed.** The times here are taken while other sequences and methods share the processor and \
its caches, each on as many threads as is said above. They compare methods of one table, no more; \
how fast the tracker is on a machine of its own, `make bench` measures.
- **Assembly state. state**: frames with the true state, %; **settled**: the same of frames more \
than {NEAR_FRAMES} away from a true switch, %; **found**: switches noticed within \
{NEAR_FRAMES} frames, early or late, %; **missed**: switches not noticed before the next one, %; \
**switch**: mean delay of the noticed ones, frames, negative is early; **beyond**: changes of \
state that were reported beyond the true ones, a sequence; \
**alarms**: parts reported to sit wrong, a sequence (nothing does in a dataset of right \
assemblies). The true state changes in the frame in \
which a part reaches its place. A method marked {TOLD} is told the true state of every frame: it \
has no figures here, and its others are helped by it.
- **Lost parts.** A pose is right if its ADD(-S) is under 10 % of the part's diameter. A stretch \
of frames without a right pose is a loss if ADD(-S) is over 10 cm in one of them or there is no \
estimate, or if it lasts until the end of the sequence, {LOST_FRAMES} frames at least. \
`jaw 120-180` are its first and last frame; `jaw 120-` never comes back.
- **Confidence and covariance.** **ECE**: expected calibration error, the mean distance between \
the confidence of a pose and the share of right poses among those of like confidence (ten bins), \
%; **NEES**: squared error of a pose weighted by the inverse of its stated covariance, over its \
degrees of freedom, mean over frames that are `tracked`: 1 is expected, more means too sure, less \
too modest; **rotation** and **translation**: of these alone; **right**: mean over right poses; \
**median**: over the median that is expected; **95 %**: poses inside the ellipsoid that should \
hold 95 %, %. A turn about an axis of symmetry is left out. Then the share of parts and frames by \
status, %."""
