executable: soil -e water.e water.spec
turtle position: P: %.9g %.9g %.9g
turtle heading: H: %.9g %.9g %.9g
