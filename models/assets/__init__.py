"""The asset bundles: one folder an asset, with its manifest and meshes."""
