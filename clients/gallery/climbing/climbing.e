executable: arvo -e climbing.e climbing.spec
turtle position: P: %.9g %.9g %.9g
turtle heading: H: %.9g %.9g %.9g
turtle up: U: %.9g %.9g %.9g
