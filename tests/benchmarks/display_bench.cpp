// How well a display's place is found, on simulated people and cameras: median and 95 % quantile of
// how far the picture's middle is off.
#include "engine-bridge/display/DisplayFit.h"
#include "tests/engine-bridge/display/CrossSimulation.h"

#include <cstdio>
#include <vector>

namespace
{

using namespace midair::bridge;

constexpr int kTrials = 400;

void printRow(const char* method, const std::vector<double>& errors_m)
{
    std::printf("%-62s%5.1f (%.1f) mm\n",
                method,
                1e3 * errors_m[errors_m.size() / 2],
                1e3 * errors_m[errors_m.size() * 95 / 100]);
}

} // namespace

int main()
{
    const Display mirror = displays::halfMirror();
    const Display window = displays::window();
    std::printf("the picture's middle, median (95 %%) of %d trials\n", kTrials);
    for (const double noise_mm : {1.0, 2.0, 5.0})
    {
        CrossSimulation simulation(mirror, 3);
        char method[80];
        std::snprintf(
            method, sizeof method, "12 crosses touched, %g mm noise a coordinate", noise_mm);
        printRow(method,
                 simulation.errors(kTrials,
                                   [&](CrossSimulation& people) {
                                       return fitTouches(guessedDisplay(mirror),
                                                         people.touches(1e-3 * noise_mm));
                                   }));
    }
    CrossSimulation three(window, 3);
    printRow("12 crosses covered from 3 places of the head, 2 mm",
             three.errors(kTrials,
                          [&](CrossSimulation& people)
                          {
                              return fitSights(guessedDisplay(window),
                                               people.sights(people.heads(3, 0.2),
                                                             kSightReach_m,
                                                             kSightNoise_m));
                          }));
    CrossSimulation six(window, 3);
    DisplayFitOptions options;
    options.fitsEye = true;
    printRow(
        "from 6 places, the eye 10 mm off and fitted as well, 2 mm",
        six.errors(kTrials,
                   [&](CrossSimulation& people)
                   {
                       const Eigen::Vector3d off = 0.01 * people.noise(1.0).normalized();
                       return fitSights(
                           guessedDisplay(window),
                           people.sights(people.heads(6, 0.15), kSightReach_m, kSightNoise_m, off),
                           options);
                   }));
    return 0;
}
