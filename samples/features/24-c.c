/* In C, without a scene graph: solves for a model, writes its drive, and plays it in the simulator
   while it rotates. Build: gcc -std=c99 24-c.c $(pkg-config --cflags --libs midair) -lm
 */

#define _POSIX_C_SOURCE 199309L

#include <math.h>
#include <midair.h>
#include <stdio.h>
#include <time.h>

static int failed(void)
{
    fprintf(stderr, "%s\n", midair_last_error());
    return 1;
}

int main(int argc, char** argv)
{
    const char* model = argc > 1 ? argv[1] : "star.obj";
    const char* drive = argc > 2 ? argv[2] : "drive.csv";
    midair_array* array = NULL;
    midair_scene* scene = NULL;
    midair_field* field = NULL;
    midair_object star = 0;
    midair_device_state state = {0};
    double level_Pa = 0.0;
    double rms = 0.0;

    if (midair_array_load("octagon", &array) < 0 || midair_scene_make(array, &scene) < 0 ||
        midair_add_file(scene, model, 0.08, &star) < 0 || /* m */
        midair_object_set(scene, star, "sampling", "vertices") < 0 ||
        midair_set(scene, "maxPressure", "2 kPa") < 0)
        return failed();

    if (midair_solve(scene, &field) < 0 || midair_field_figure(field, "level_Pa", &level_Pa) < 0 ||
        midair_field_figure(field, "rms", &rms) < 0 ||
        midair_field_write_drive(field, 0, drive) < 0)
        return failed();
    midair_field_close(field);
    printf("%.0f Pa, error %.3f %%\n", level_Pa, 100.0 * rms);

    if (midair_play(scene, "sim:") < 0) return failed();
    for (int frame = 0; frame < 600 && state.played < 10; ++frame)
    {
        const double angle = 0.02 * frame;
        double pose[16] = {0}; /* a turn about z */
        const struct timespec pause = {0, 16666667};
        pose[0] = pose[5] = cos(angle);
        pose[4] = sin(angle);
        pose[1] = -pose[4];
        pose[10] = pose[15] = 1.0;
        if (midair_set_pose(scene, star, pose) < 0 || midair_update(scene, frame / 60.0) < 0)
            return failed();
        nanosleep(&pause, NULL);
        if (midair_state(scene, &state) < 0) return failed();
    }
    printf("%s\n", state.played >= 10 ? "it turns, and is played" : "not played");
    midair_scene_close(scene); /* silences the device */
    midair_array_close(array);
    return state.played >= 10 ? 0 : 1;
}
