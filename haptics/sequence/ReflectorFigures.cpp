#include "haptics/sequence/ReflectorFigures.h"

#include "haptics/points/FittedLevel.h"
#include "haptics/propagation/Reflections.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Errors of the points, y / (s a) - 1, and the level s.
struct PointErrors
{
    Eigen::VectorXd each;
    double level_Pa = 0.0;

    double rms() const { return std::sqrt(each.squaredNorm() / static_cast<double>(each.size())); }
};

PointErrors errorsOf(const FieldSequence& sequence,
                     const Eigen::VectorXd& targets,
                     const TransducerArray& array,
                     const Medium& medium,
                     int threads,
                     const base::StopToken& stop)
{
    const Eigen::VectorXd y =
        achievedPressure(sequence, array, medium, threads, stop).cast<double>();
    PointErrors errors;
    errors.level_Pa = fittedLevel(y, targets);
    errors.each = errors.level_Pa > 0.0
                      ? Eigen::VectorXd(y.array() / (errors.level_Pa * targets.array()) - 1.0)
                      : Eigen::VectorXd::Constant(y.size(), -1.0);
    return errors;
}

} // namespace

ReflectorFigures reflectorFigures(const FieldSequence& sequence,
                                  const TransducerArray& array,
                                  const Medium& medium,
                                  int threads,
                                  const base::StopToken& stop)
{
    ReflectorFigures figures;
    Eigen::VectorXd targets = sequence.points().targets;
    if (targets.size() == 0 || sequence.isEmpty()) return figures;
    raiseTargets(targets);
    const auto errorsIn = [&](const TransducerArray& reality)
    { return errorsOf(sequence, targets, reality, medium, threads, stop); };
    TransducerArray reality = array;
    reality.reflectors.clear();
    const PointErrors free = errorsIn(reality);
    figures.freeRms = free.rms();
    figures.freeLevel_Pa = free.level_Pa;
    const PointErrors known = errorsIn(array);
    figures.rms = known.rms();
    figures.worst = known.each.cwiseAbs().maxCoeff();
    figures.level_Pa = known.level_Pa;
    double square = figures.rms * figures.rms;
    for (std::size_t k = 0; k < array.reflectors.size(); ++k)
    {
        const Reflector& one = array.reflectors[k];
        if (one.reflection == 0.0) continue;
        for (const double side : {-1.0, 1.0})
        {
            reality.reflectors = array.reflectors;
            reality.reflectors[k].position += side * 1e-3 * one.accuracy_mm * one.normal;
            square += 0.5 * (errorsIn(reality).each - known.each).squaredNorm() /
                      static_cast<double>(targets.size());
        }
    }
    figures.expectedRms = std::sqrt(square);
    return figures;
}

int hiddenTransducers(const Eigen::Matrix3Xd& points,
                      const TransducerArray& array,
                      const Medium& medium)
{
    if (points.cols() == 0) return 0;
    const double wavelength_m = medium.wavelength(array.frequency_Hz);
    // Every n-th point: neighbours are in the same shadow.
    const Eigen::Index step = std::max<Eigen::Index>(1, points.cols() / 16);
    int hidden = 0;
    for (Eigen::Index i = 0; i < array.size(); ++i)
    {
        if (array.gain.size() > 0 && array.gain[i] == 0.0) continue;
        int inShadow = 0, all = 0;
        for (Eigen::Index l = 0; l < points.cols(); l += step, ++all)
        {
            double left = 1.0;
            const Eigen::Vector3d from = array.positions.col(i), to = points.col(l);
            for (const Reflector& one : array.reflectors)
                if (isShaded(one, from, to))
                    left *=
                        std::norm(1.0 - one.reflection * shareTurned(one, from, to, wavelength_m));
            inShadow += left < 0.5 ? 1 : 0;
        }
        hidden += 2 * inShadow > all ? 1 : 0;
    }
    return hidden;
}

std::string
whyUncorrectable(const Eigen::Matrix3Xd& points, const TransducerArray& array, const Medium& medium)
{
    const double wavelength_m = medium.wavelength(array.frequency_Hz);
    for (std::size_t k = 0; k < array.reflectors.size(); ++k)
    {
        const Reflector& one = array.reflectors[k];
        if (one.reflection == 0.0) continue;
        if (one.accuracy_mm > kMostCorrectedAccuracy_mm && !one.isBoard)
            return fmt::format("the accuracy of {} is {:g} mm, and a correction needs {:g} mm or "
                               "better",
                               one.called(k),
                               one.accuracy_mm,
                               kMostCorrectedAccuracy_mm);
        for (Eigen::Index l = 0; l < points.cols(); ++l)
            if (const double distance_m = one.distanceTo(points.col(l)); distance_m < wavelength_m)
                return fmt::format("point {} is {:.2g} mm from {}, nearer than a wavelength, "
                                   "{:.2g} mm",
                                   l,
                                   1e3 * distance_m,
                                   one.called(k),
                                   1e3 * wavelength_m);
    }
    return {};
}

} // namespace midair::haptics
