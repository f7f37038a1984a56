/* A program in C99 with libmidair alone: a focus over a board, solved, played in the simulator, and heard. */
#include <midair.h>

#include <stdio.h>
#include <string.h>
#include <time.h>

static int failed(const char* what)
{
    fprintf(stderr, "%s: %s\n", what, midair_last_error());
    return 1;
}

/* A solver of the program's own: all waves arrive at the first point in phase. */
static int32_t
focus(void* user, const midair_problem* problem, float* activations, char* error, size_t error_size)
{
    uint32_t i;
    (void)error;
    (void)error_size;
    ++*(int*)user;
    for (i = 0; i < problem->transducers; ++i)
    {
        /* The conjugate, as long as it is at the strongest transducer or shorter. */
        const float real = problem->matrix[2 * i];
        const float imaginary = problem->matrix[2 * i + 1];
        const float size = (real < 0 ? -real : real) + (imaginary < 0 ? -imaginary : imaginary);
        if (size > 0)
        {
            activations[2 * i] = real / size;
            activations[2 * i + 1] = -imaginary / size;
        }
    }
    return 0;
}

int main(void)
{
    static int calls = 0;
    const double place[3] = {0.0, 0.0, 0.15};
    midair_array* array = NULL;
    midair_scene* scene = NULL;
    midair_field* field = NULL;
    midair_object point = 0;
    midair_device_state state;
    double level_Pa = 0.0;
    float felt_Pa = 0.0F;
    int frame = 0;

    if (midair_version() / 100 != MIDAIR_VERSION / 100) return failed("another version");
    if (midair_register_solver("focus", focus, &calls) < 0) return failed("register");
    if (midair_array_load("board", &array) < 0) return failed("board");
    if (midair_scene_make(array, &scene) < 0) return failed("scene");
    midair_array_close(array);
    if (midair_add_points(scene, place, NULL, 1, 0, &point) < 0) return failed("point");
    if (midair_set(scene, "solver", "focus") < 0) return failed("solver");
    if (midair_solve(scene, &field) != MIDAIR_OK) return failed("solve");
    if (midair_field_figure(field, "level_Pa", &level_Pa) < 0) return failed("level");
    if (midair_field_felt(field, place, 1, &felt_Pa) < 0) return failed("felt");
    midair_field_close(field);
    if (calls == 0 || felt_Pa < 0.98 * level_Pa || felt_Pa > 1.02 * level_Pa) return failed("focus");

    if (midair_set(scene, "solver", "") < 0) return failed("solver");
    if (midair_play(scene, "sim:") < 0) return failed("play");
    memset(&state, 0, sizeof state);
    for (frame = 0; frame < 1000 && state.played == 0; ++frame)
    {
        const struct timespec pause = {0, 10000000};
        if (midair_update(scene, 0.01 * frame) < 0) return failed("update");
        nanosleep(&pause, NULL);
        if (midair_state(scene, &state) < 0) return failed("state");
    }
    if (midair_scene_close(scene) < 0) return failed("close");
    printf("own solver %.0f Pa, %.0f Pa felt; %lu fields played\n",
           level_Pa,
           (double)felt_Pa,
           (unsigned long)state.played);
    return state.played > 0 && midair_update(scene, 0.0) == MIDAIR_CLOSED ? 0 : 1;
}
