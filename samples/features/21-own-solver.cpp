// A custom solver: takes control points and the matrix, returns activations. The kit rounds them to
// the device's levels, applies caps and measures the error of the played field.

#include "Frames.h"

#include <osgMidair/FieldSolver>
#include <osgMidair/HapticPoints>

#include <cmath>

namespace
{

/// Back-propagation: each transducer is in phase with the sum of the points' fields.
class BackPropagation : public osgMidair::FieldSolver
{
public:
    bool
    solve(const Problem& problem, std::complex<float>* activations, std::string& error) override
    {
        for (unsigned int j = 0; j < problem.transducers; ++j)
        {
            if (problem.isStopped()) return false; // a newer frame has come
            std::complex<float> sum;
            for (unsigned int i = 0; i < problem.points; ++i)
                sum += static_cast<float>(problem.targets[i]) *
                       std::conj(problem.matrix[std::size_t(i) * problem.transducers + j]);
            if (sum != 0.0F) activations[j] = sum / std::abs(sum);
        }
        error.clear();
        return true;
    }

protected:
    ~BackPropagation() override = default;
};

void print(const osgMidair::HapticStatistics& now, const char* name)
{
    std::printf("%s: %.0f Pa, error %.2f %%\n", name, now.level_Pa, 100.0 * now.rms);
}

} // namespace

int main()
{
    std::string error;
    if (!osgMidair::registerSolver(
            "mine",
            [] { return osg::ref_ptr<osgMidair::FieldSolver>(new BackPropagation); },
            error))
    {
        std::fprintf(stderr, "%s\n", error.c_str());
        return 1;
    }
    const osg::ref_ptr<osgMidair::HapticPoints> points = new osgMidair::HapticPoints;
    points->setPoints({{-0.02, 0.0, 0.0}, {0.0, 0.0, 0.02}, {0.02, 0.0, 0.0}}, {1.0, 2.0, 1.0});
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->setSolver("mine"); // in files: Solver "mine"; in other programs: -O solver=mine
    scene->addChild(points);

    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    print(scene->getStatistics(), "mine");
    scene->setSolver(""); // the kit's default
    frames.run(0.5);
    print(scene->getStatistics(), "the kit's");
    return 0;
}
