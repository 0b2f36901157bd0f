executable: ornament -e ornament.e ornament.spec
turtle position: P: %.9g %.9g %.9g
