#include "samples/experiments/paper/PaperArray.h"

#include "device/drive/DriveEncoder.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "samples/shared/views/FieldImage.h"

#include <complex>
#include <cstdio>
#include <random>
#include <vector>

namespace midair::samples
{

using Eigen::Vector3d;

namespace
{

haptics::ControlPoints equalTargets(const Eigen::Matrix3Xd& positions)
{
    haptics::ControlPoints points;
    points.positions = positions;
    points.normals = Vector3d::UnitZ().replicate(1, positions.cols());
    points.targets = Eigen::VectorXd::Ones(positions.cols());
    return points;
}

} // namespace

double PaperField::evenness() const
{
    return achieved_Pa.minCoeff() / achieved_Pa.maxCoeff();
}

PaperArray::PaperArray() : _array(haptics::TransducerArray::octagonalPrism())
{
    _array.drive.amplitudeLevels = device::amplitudeLevels();
    _medium.temperature_C = 14.5;
}

// A solver starts from the phases that its last field has at the new points. So it first makes a
// field with a copy of the array whose transducers are off by random phases: played by the array
// itself that field is speckle, whose phases at points half a wavelength apart or more are random.
void PaperArray::randomise(haptics::HologramSolver& solver, std::uint64_t seed) const
{
    haptics::TransducerArray other = _array;
    other.phaseOffset_rad.resize(other.size());
    std::mt19937_64 random(seed);
    for (double& phase : other.phaseOffset_rad)
        phase = base::kTwoPi * static_cast<double>(random() >> 11U) * 0x1p-53;
    Eigen::VectorXcf q;
    solver.solve(equalTargets(Vector3d::Zero()), other, _medium, q);
}

PaperField PaperArray::solve(const Eigen::Matrix3Xd& positions, const PaperSolve& how) const
{
    PaperField field;
    field.points = equalTargets(positions);
    haptics::SolverOptions options;
    options.maxIterations = 1000;
    options.rmsTolerance = 0.0;
    options.phaseOnly = how.phaseOnly;
    options.lambda = how.lambda;
    options.seed += how.start;
    const auto solver = haptics::makeSolver(how.solver, options);
    if (how.start > 0) randomise(*solver, how.start);
    Eigen::VectorXcf q;
    field.report = solver->solve(field.points, _array, _medium, q);
    device::DriveSignal signal;
    device::encode(q.data(), static_cast<int>(q.size()), signal);
    std::vector<std::complex<float>> played;
    device::decode(signal, played);
    field.played = Eigen::Map<Eigen::VectorXcf>(played.data(), q.size());
    field.achieved_Pa = pressure(positions, field);
    return field;
}

Eigen::VectorXd PaperArray::pressure(const Eigen::Matrix3Xd& points, const PaperField& field) const
{
    return haptics::pressureAt(points, _array, _medium, field.played, 2).cwiseAbs().cast<double>();
}

double PaperArray::halfWidth_m(const PaperField& field,
                               const Vector3d& centre,
                               const Vector3d& direction) const
{
    constexpr double kStep_m = 5e-5;
    constexpr int kSteps = 600;
    double width_m = 0.0;
    for (const double sign : {-1.0, 1.0})
    {
        Eigen::Matrix3Xd ray(3, kSteps);
        for (int i = 0; i < kSteps; ++i)
            ray.col(i) = centre + sign * i * kStep_m * direction;
        const Eigen::VectorXd p = pressure(ray, field);
        int i = 1;
        while (i < kSteps - 1 && p[i] > 0.5 * p[0])
            ++i;
        width_m += kStep_m * (i - 1 + (p[i - 1] - 0.5 * p[0]) / (p[i - 1] - p[i]));
    }
    return width_m;
}

double PaperArray::inPhase_Pa(const Vector3d& point) const
{
    return haptics::referencePropagationMatrix(point, _array, _medium).cwiseAbs().sum();
}

void PaperArray::draw(const PaperField& field,
                      const std::string& title,
                      const std::string& path) const
{
    FieldImage image;
    image.grid = bestSlice(field.points, 0.03, 4e-4);
    image.pressure_Pa = haptics::pressureAt(image.grid.points(), _array, _medium, field.played, 2);
    image.points = field.points;
    image.achieved_Pa = field.achieved_Pa.cast<float>();
    image.level_Pa = field.report.level_Pa;
    image.title = title;
    std::string message;
    writeFieldImage(path, image, &message);
    if (!message.empty()) std::fprintf(stderr, "midair-paper: %s\n", message.c_str());
}

} // namespace midair::samples
