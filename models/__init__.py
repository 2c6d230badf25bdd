"""What is known before the first frame: poses, cameras, assets, viewpoint models, the workbench."""
