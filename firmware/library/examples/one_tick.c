/* One tick of the controller: what a real-time loop does every 2 ms. C11 or C++11; docs/library.md says how to build
 * it. Numbers are printed with nine digits, which is every bit of a float. */
#include "tactus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The library found itself broken: here a real program takes the torque off. */
void tactus_panic(const char *file, size_t file_bytes, uint32_t line) {
    fprintf(stderr, "tactus: %.*s:%u\n", (int)file_bytes, file, (unsigned)line);
    abort();
}

static void check(TactusResult result, const char *what) {
    if (result != TACTUS_RESULT_OK) {
        fprintf(stderr, "%s: TactusResult %d\n", what, (int)result);
        exit(1);
    }
}

/* Static: a controller is too large for most stacks, and an embedded program wants to see it in its map file. */
static TactusControllerMemory memory;

int main(void) {
    TactusController *controller = NULL;
    TactusSetup setup;
    TactusReadings readings;
    TactusInputs inputs;
    TactusOutputs outputs;
    TactusBelief belief;
    /* Hand straight down above the table, fingers open. */
    static const float home_rad[TACTUS_ARM_JOINTS] = {
        -0.09966867f, 0.45729157f, 0.0f, 2.0252702f, 0.0f, 0.65903074f, -1.670465f,
    };
    int j;

    if (tactus_abi_version() != TACTUS_ABI_VERSION) {
        fprintf(stderr, "tactus.h is of version %d, the library of version %u\n", TACTUS_ABI_VERSION,
                (unsigned)tactus_abi_version());
        return 1;
    }
    printf("a controller takes %zu of %zu bytes\n", tactus_controller_size(), sizeof memory);
    check(tactus_controller_create(&memory, sizeof memory, &controller), "create");

    memset(&setup, 0, sizeof setup);
    memset(&readings, 0, sizeof readings);
    memset(&inputs, 0, sizeof inputs);

    /* The mission: a box, where it should be, and how far off that may be. */
    setup.shape.kind = TACTUS_SHAPE_KIND_CUBOID;
    setup.shape.half_extents_m[0] = 0.1f;
    setup.shape.half_extents_m[1] = 0.05f;
    setup.shape.half_extents_m[2] = 0.1f;
    setup.guess.x_m = 0.21f;
    setup.guess.y_m = -0.108f;
    setup.interval.x_m = 0.05f;
    setup.interval.y_m = 0.05f;
    setup.interval.phi_rad = 0.35f;
    setup.displacement_m[0] = -0.5f;
    setup.mass_kg = 0.6f;
    setup.trials_max = 12;
    check(tactus_controller_begin(controller, &setup), "begin");

    /* What the drives and sensors of this tick say. */
    for (j = 0; j < TACTUS_ARM_JOINTS; j++) {
        readings.arm_q_rad[j] = home_rad[j];
    }
    readings.valid = TACTUS_VALID_ALL;
    inputs.readings = &readings;

    check(tactus_controller_tick(controller, 0, &inputs, &outputs), "tick");

    for (j = 0; j < TACTUS_ARM_JOINTS; j++) {
        printf("J%d %.9g rad -> %.9g Nm\n", j + 1, readings.arm_q_rad[j], outputs.commands.arm_tau_nm[j]);
    }
    printf("phase %d, %u event(s)\n", (int)outputs.phase, (unsigned)outputs.event_count);

    check(tactus_controller_belief(controller, &belief), "belief");
    printf("belief %.9g %.9g %.9g\n", belief.pose.x_m, belief.pose.y_m, belief.pose.phi_rad);
    for (j = 0; j < 3; j++) {
        printf("covariance %.9g %.9g %.9g\n", belief.covariance[j][0], belief.covariance[j][1], belief.covariance[j][2]);
    }
    return 0;
}
