"""What is known before the first frame: poses, cameras, assets, viewpoint models, the workbench."""

from snapfit.models.kernel_cache import prepare_kernel_cache

prepare_kernel_cache()
