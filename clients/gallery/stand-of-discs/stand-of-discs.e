executable: ecosystem -e stand-of-discs.e stand-of-discs.spec
turtle position: P: %.9g %.9g %.9g
