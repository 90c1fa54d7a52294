/* The pose estimator by itself: three touches of a box go in, its pose comes out. For loops that have their own motion
 * and safety. C11 or C++11; docs/library.md says how to build it. */
#include "tactus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* A touch: where the hand stood, and the inner angle at which each finger met the box. The box of this example stands
 * at x 0.22 m, y -0.08 m, phi 0.15 rad. */
typedef struct Touch {
    TactusTransform world_from_hand;
    float spread_rad;
    float onset_rad[TACTUS_FINGERS];
} Touch;

static const Touch touches[] = {
    {{{0.2f, -0.1f, 0.325f}, {0.70710677f, 0.70710677f, 0.0f, 0.0f}}, 0.0f, {0.91925627f, 0.8538208f, 1.1767954f}},
    {{{0.2f, -0.1f, 0.325f}, {0.70710677f, 0.70710677f, 0.0f, 0.0f}}, 1.5707964f, {1.0100583f, 0.5340594f, 1.1767954f}},
    {{{0.24f, -0.1f, 0.325f}, {0.70710677f, -0.70710677f, 0.0f, 0.0f}}, 0.0f, {1.26458f, 1.1967514f, 0.82836926f}},
};

/* The fingers open on the way down, radians. */
static const float open_rad = 0.25f;

/* The hand with one finger closed to `inner_rad`, the others open; the tips follow by a third. */
static TactusHand hand_at(const Touch *touch, int finger, float inner_rad) {
    TactusHand hand;
    int f;
    hand.world_from_hand = touch->world_from_hand;
    hand.spread_rad = touch->spread_rad;
    for (f = 0; f < TACTUS_FINGERS; f++) {
        hand.inner_rad[f] = f == finger ? inner_rad : open_rad;
        hand.distal_rad[f] = hand.inner_rad[f] / 3.0f;
    }
    return hand;
}

static TactusEstimatorMemory memory;

int main(void) {
    TactusEstimator *estimator = NULL;
    TactusPrior prior;
    TactusBelief belief;
    bool done = false;
    size_t t;
    int slices = 0;

    memset(&prior, 0, sizeof prior);
    prior.shape.kind = TACTUS_SHAPE_KIND_CUBOID;
    prior.shape.half_extents_m[0] = 0.1f;
    prior.shape.half_extents_m[1] = 0.05f;
    prior.shape.half_extents_m[2] = 0.1f;
    prior.guess.x_m = 0.2f;
    prior.guess.y_m = -0.1f;
    prior.interval.x_m = 0.05f;
    prior.interval.y_m = 0.05f;
    prior.interval.phi_rad = 0.35f;
    printf("an estimator takes %zu of %zu bytes\n", tactus_estimator_size(), sizeof memory);
    check(tactus_estimator_create(&memory, sizeof memory, &prior, &estimator), "create");

    for (t = 0; t < sizeof touches / sizeof touches[0]; t++) {
        TactusHand open = hand_at(&touches[t], 0, open_rad);
        int finger;
        check(tactus_estimator_begin_touch(estimator), "begin_touch");
        /* Down beside the box, and nothing was felt ... */
        check(tactus_estimator_add_free(estimator, &open, 0x7), "add_free");
        /* ... until the fingers closed. */
        for (finger = 0; finger < TACTUS_FINGERS; finger++) {
            TactusHand closed = hand_at(&touches[t], finger, touches[t].onset_rad[finger]);
            check(tactus_estimator_add_contact(estimator, &closed, (uint8_t)finger, TACTUS_CONTACT_KIND_CLOSING),
                  "add_contact");
        }
        /* Some 70,000 instructions of a Cortex-M4F a tick: the fit never holds the loop up. */
        for (done = false; !done; slices++) {
            check(tactus_estimator_update(estimator, 700, &done), "update");
        }
        check(tactus_estimator_belief(estimator, &belief), "belief");
        printf("touch %zu: belief %.9g %.9g %.9g, +-%.9g m, +-%.9g rad, readiness %d\n", t + 1, belief.pose.x_m,
               belief.pose.y_m, belief.pose.phi_rad, belief.half_width_m, belief.half_width_rad, (int)belief.readiness);
    }
    printf("%d slices; %s\n", slices, belief.readiness == TACTUS_READINESS_READY ? "ready to grasp" : "not yet ready");
    return 0;
}
