executable: chiba -e light.e light.spec
turtle position: P: %.9g %.9g %.9g
