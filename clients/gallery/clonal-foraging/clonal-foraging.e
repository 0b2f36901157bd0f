executable: clover -e clonal-foraging.e clonal-foraging.spec
turtle position: P: %.9g %.9g %.9g
