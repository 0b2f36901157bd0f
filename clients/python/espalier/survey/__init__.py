"""Plants and fields as files of surveyors: .vtp meshes to LAS point clouds and OBJ obstacles, .vti fields to GeoTIFF.

    python3 -m espalier.survey plant.vtp plant.las --spacing 0.05     # points of its surface
    python3 -m espalier.survey plant.vtp plant.obj                    # for "meshFile" of an environment
    python3 -m espalier.survey light.vti light.tif --epsg 25832 --origin 400003,5600002,100

In the world east is x, up is y and south is z. `origin` is the east, north and height of the world's origin in the file.
"""

from __future__ import annotations

from .geotiff import heights_of as heights_of, write_geotiff as write_geotiff
from .las import surface_points as surface_points, write_las as write_las
from .vtp import SurveyError as SurveyError, VtpMesh as VtpMesh, read_vtp as read_vtp, write_obj as write_obj
