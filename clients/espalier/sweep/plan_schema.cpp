#include "clients/espalier/sweep/plan.h"

namespace espalier::command {

std::string_view planSchema() {
  return R"json({
  "$schema": "https://json-schema.org/draft/2020-12/schema",
  "title": "Plan of espalier sweep",
  "type": "object",
  "additionalProperties": false,
  "required": ["model", "measures"],
  "properties": {
    "$schema": {"type": "string"},
    "title": {"description": "for readers"},
    "model": {"type": "string", "description": "model folder or L-system file, beside the plan or in the working folder, or a gallery model"},
    "object": {"type": "string", "description": "one of several models of a folder with specifications"},
    "view": {"type": "string", "description": "view file; default: the model's own"},
    "dialect": {"type": "string", "description": "dialect of the model; default: found by its content"},
    "compatibility": {"enum": ["cpfg", "cpfg-batch"]},
    "environment": {"type": ["string", "object", "array"], "description": "built-in process, file, or the configuration itself; default: the model's own"},
    "world": {"type": ["string", "object"], "description": "world file, or its members; default: world.json of the model's folder"},
    "stepDuration": {"type": "string", "description": "time of a step, as 1 h or 0.25 d; default: the world's"},
    "steps": {"type": "integer", "minimum": 0, "description": "default: the model's derivation length"},
    "seed": {"type": "integer", "minimum": 0, "default": 1, "description": "of runs without a seed of their own"},
    "answered": {"type": "boolean", "default": false, "description": "measures see the answers of the environment to the last string"},
    "defines": {"type": "object", "additionalProperties": {"type": ["number", "string"]}, "description": "macros, the same in all runs"},
    "limits": {"type": "object", "additionalProperties": {"type": ["number", "string"]}, "description": "as --limit of run"},
    "parameters": {"type": "object", "additionalProperties": {"$ref": "#/$defs/parameter"}},
    "runs": {
      "oneOf": [
        {"type": "object", "additionalProperties": false, "required": ["table"], "properties": {"table": {"type": "string", "description": "CSV or TSV with a line of names; a column 'seed' gives seeds"}}},
        {"type": "object", "additionalProperties": false, "required": ["rows"], "properties": {"rows": {"type": "array", "minItems": 1, "items": {"type": "object", "additionalProperties": {"type": "number"}}}}},
        {"type": "object", "additionalProperties": false, "required": ["design"], "properties": {"design": {"const": "grid"}, "levels": {"type": "integer", "minimum": 2, "default": 4}}},
        {"type": "object", "additionalProperties": false, "required": ["design", "count"], "properties": {"design": {"enum": ["random", "latin-hypercube"]}, "count": {"type": "integer", "minimum": 1}, "seed": {"type": "integer", "minimum": 0, "default": 1}}},
        {"type": "object", "additionalProperties": false, "required": ["design", "count"], "properties": {"design": {"enum": ["sobol", "saltelli"]}, "count": {"type": "integer", "minimum": 1}, "shift": {"type": "integer", "minimum": 0, "description": "seed of a random digital shift; default: none"}}},
        {"type": "object", "additionalProperties": false, "required": ["design", "trajectories"], "properties": {"design": {"const": "morris"}, "trajectories": {"type": "integer", "minimum": 1}, "levels": {"type": "integer", "minimum": 2, "multipleOf": 2, "default": 4}, "seed": {"type": "integer", "minimum": 0, "default": 1}}}
      ]
    },
    "replicates": {
      "oneOf": [
        {"type": "integer", "minimum": 1},
        {"type": "object", "additionalProperties": false, "properties": {"count": {"type": "integer", "minimum": 1}, "seed": {"type": "integer", "minimum": 0}, "common": {"type": "boolean", "default": true, "description": "replicate r has the same seed in every row"}}}
      ]
    },
    "measures": {"type": "object", "minProperties": 1, "additionalProperties": {"$ref": "#/$defs/measure"}},
    "files": {"type": "array", "items": {"type": "object", "additionalProperties": false, "required": ["name"], "properties": {"name": {"type": "string"}, "every": {"type": "integer", "minimum": 1, "default": 1}}}}
  },
  "$defs": {
    "pair": {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2},
    "parameter": {
      "type": "object",
      "additionalProperties": false,
      "properties": {
        "define": {"type": "string", "description": "a #define of the model; default: found by the parameter's name"},
        "variable": {"type": "string", "description": "a variable of the main L-system; never compiles the model again"},
        "environment": {"type": "string", "description": "JSON pointer into the environment, as /radius or /0/radius"},
        "uniform": {"$ref": "#/$defs/pair"},
        "log": {"$ref": "#/$defs/pair"},
        "normal": {"$ref": "#/$defs/pair", "description": "mean, standard deviation"},
        "integer": {"$ref": "#/$defs/pair"},
        "discrete": {"type": "array", "items": {"type": "number"}, "minItems": 1}
      }
    },
    "measure": {
      "type": "object",
      "additionalProperties": false,
      "properties": {
        "count": {"type": "string", "description": "modules: *, A or A(l,w)"},
        "sum": {"type": "string", "description": "an expression over the names in 'of'"},
        "mean": {"type": "string"},
        "minimum": {"type": "string"},
        "maximum": {"type": "string"},
        "deviation": {"type": "string"},
        "median": {"type": "string"},
        "quantile": {"type": "number", "minimum": 0, "maximum": 1},
        "value": {"type": "string", "description": "the expression of a quantile"},
        "of": {"type": "string", "description": "modules with names for their parameters, as F(l,w)"},
        "where": {"type": "string", "description": "a condition over the same names"},
        "variable": {"type": "string"},
        "plant": {"enum": ["height", "lowest", "extentX", "extentY", "extentZ", "spread", "length", "segments", "woodArea", "woodVolume", "organs", "leafArea", "silhouetteTop", "silhouetteFront", "silhouetteSide", "sky", "symmetry", "stability", "branching"]},
        "profile": {"enum": ["length", "woodArea", "woodVolume", "leafArea", "organs"]},
        "along": {"enum": ["height", "radius"], "default": "height"},
        "bins": {"type": "integer", "minimum": 1, "maximum": 1000, "default": 10},
        "to": {"type": "number", "exclusiveMinimum": 0},
        "mtg": {"enum": ["vertices", "axes", "tips", "verticesPerAxis", "maximumOrder", "depth", "strahler"]},
        "order": {"type": "integer", "minimum": 0},
        "at": {"oneOf": [{"type": "integer", "minimum": 0}, {"type": "array", "minItems": 1, "items": {"type": "integer", "minimum": 0}}, {"const": "every"}]}
      }
    }
  }
}
)json";
}

}  // namespace espalier::command
