executable: honda81 -e ulam-warburton-2d.e ulam-warburton-2d.spec
turtle position: P: %.9g %.9g %.9g
