/* An environment plug-in in C: what asks may grow below a ceiling that comes down by a little every step.
 *
 *     cc -shared -fPIC -I. environment/plugin_example/ceiling.c -o libceiling.so
 *     espalier derive MODEL.l --environment ./libceiling.so
 *
 * Configuration: {"height": 3, "sinking": 0}, in world length units and units a step.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "environment/plugin.h"

typedef struct ceiling {
  double height;  /* at step 0 */
  double sinking; /* a step */
  uint64_t steps; /* made so far: the state */
} ceiling;

/* The number behind a key of a flat JSON object; a program with more to read uses a JSON library. Returns 0 when what
 * stands there is no number. */
static int read_number(const char* json, const char* key, double* value) {
  const char* found = strstr(json, key);
  char* end = NULL;
  if (found == NULL || (found = strchr(found, ':')) == NULL) {
    return 1; /* keeps its default */
  }
  *value = strtod(found + 1, &end);
  return end != found + 1;
}

static void* create(const char* configuration, char* message, size_t message_size) {
  ceiling* self = malloc(sizeof(ceiling));
  if (self == NULL) {
    snprintf(message, message_size, "out of memory");
    return NULL;
  }
  *self = (ceiling){.height = 3.0, .sinking = 0.0, .steps = 0};
  if (!read_number(configuration, "\"height\"", &self->height) ||
      !read_number(configuration, "\"sinking\"", &self->sinking)) {
    snprintf(message, message_size, "'height' and 'sinking' are numbers");
    free(self);
    return NULL;
  }
  return self;
}

static void destroy(void* instance) {
  free(instance);
}

static int open_simulation(void* instance, const espalier_context* context, char* message, size_t message_size) {
  (void)context;
  (void)message;
  (void)message_size;
  ((ceiling*)instance)->steps = 0;
  return 0;
}

static int step(void* instance, const espalier_queries* queries, espalier_replies* replies, char* message,
                size_t message_size) {
  ceiling* self = instance;
  const double height = self->height - self->sinking * (double)self->steps;
  size_t i;
  if (height < 0.0) {
    snprintf(message, message_size, "the ceiling has reached the ground after %llu steps; take a smaller 'sinking'",
             (unsigned long long)self->steps);
    return 1;
  }
  for (i = 0; i < queries->count; ++i) {
    const uint64_t first = queries->parameter_offset[i];
    if (queries->parameter_offset[i + 1] > first) {
      replies->values[first] = queries->position[3 * i + 1] < height ? 1.0 : 0.0;
      replies->is_set[first] = 1;
    }
  }
  ++self->steps;
  return 0;
}

static int tick(void* instance, uint64_t completed, char* message, size_t message_size) {
  (void)completed;
  (void)message;
  (void)message_size;
  ++((ceiling*)instance)->steps;
  return 0;
}

static size_t save(void* instance, void* buffer, size_t capacity) {
  const ceiling* self = instance;
  if (capacity >= sizeof(self->steps)) {
    memcpy(buffer, &self->steps, sizeof(self->steps));
  }
  return sizeof(self->steps);
}

static int restore(void* instance, const void* state, size_t state_size, char* message, size_t message_size) {
  ceiling* self = instance;
  if (state_size != sizeof(self->steps)) {
    snprintf(message, message_size, "a state of %zu bytes instead of %zu", state_size, sizeof(self->steps));
    return 1;
  }
  memcpy(&self->steps, state, sizeof(self->steps));
  return 0;
}

const espalier_plugin* espalier_plugin_entry(void) {
  static const espalier_variable outputs[] = {{"mayGrow", "1"}};
  static const espalier_plugin table = {
      .version = ESPALIER_PLUGIN_VERSION,
      .size = sizeof(espalier_plugin),
      .name = "ceiling",
      .summary = "A module may grow while it is below a ceiling.",
      .needs = ESPALIER_NEEDS_POSITION,
      .is_stateful = 1,
      .output_count = 1,
      .outputs = outputs,
      .create = create,
      .destroy = destroy,
      .open = open_simulation,
      .step = step,
      .tick = tick,
      .save = save,
      .restore = restore,
  };
  return &table;
}
