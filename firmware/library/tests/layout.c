/* Prints what the compiler of C makes of the header's structs; tests/tests/c_library.rs compares it with Rust's. */
#include "tactus.h"

#include <stdio.h>

void tactus_panic(const char *file, size_t file_bytes, uint32_t line) {
    (void)file;
    (void)file_bytes;
    (void)line;
}

#define SIZE(type) printf(#type " %zu\n", sizeof(type))
#define FIELD(type, field) printf(#type "." #field " %zu\n", offsetof(type, field))

int main(void) {
    SIZE(TactusResult);
    SIZE(TactusPhase);
    SIZE(TactusPose);
    SIZE(TactusInterval);
    SIZE(TactusShape);
    SIZE(TactusTransform);
    SIZE(TactusBelief);
    FIELD(TactusBelief, covariance);
    FIELD(TactusBelief, readiness);
    FIELD(TactusBelief, collisions);
    SIZE(TactusMode);
    SIZE(TactusReadings);
    FIELD(TactusReadings, tip_torque_nm);
    FIELD(TactusReadings, valid);
    SIZE(TactusImage);
    FIELD(TactusImage, pad);
    SIZE(TactusHandCommand);
    SIZE(TactusCommands);
    SIZE(TactusHand);
    FIELD(TactusHand, spread_rad);
    SIZE(TactusSetup);
    FIELD(TactusSetup, trials_max);
    SIZE(TactusOutcome);
    SIZE(TactusPlanRequest);
    FIELD(TactusPlanRequest, touch);
    SIZE(TactusKnot);
    SIZE(TactusPlanAnswer);
    FIELD(TactusPlanAnswer, refusal);
    SIZE(TactusRolloutRequest);
    SIZE(TactusRollout);
    FIELD(TactusRollout, request);
    SIZE(TactusEvent);
    FIELD(TactusEvent, belief);
    SIZE(TactusInputs);
    FIELD(TactusInputs, image_count);
    SIZE(TactusOutputs);
    FIELD(TactusOutputs, event_count);
    FIELD(TactusOutputs, outcome);
    SIZE(TactusPrior);
    SIZE(TactusControllerMemory);
    SIZE(TactusEstimatorMemory);
    return 0;
}
