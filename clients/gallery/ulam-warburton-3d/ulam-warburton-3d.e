executable: honda81 -e ulam-warburton-3d.e ulam-warburton-3d.spec
turtle position: P: %.9g %.9g %.9g
