"""Keys of a deployment: its certificate authority, certificates, and the files that hold them."""
