executable: soil -e roots-and-stones.e roots-and-stones.spec
turtle position: P: %.9g %.9g %.9g
turtle heading: H: %.9g %.9g %.9g
