executable: density3d -e crowded-bush.e crowded-bush.spec
turtle position: P: %.9g %.9g %.9g
