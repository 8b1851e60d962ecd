"""Where blocks touch: the joints of a scene, once for edges in the plane and faces in space."""
