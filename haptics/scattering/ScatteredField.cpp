#include "haptics/scattering/ScatteredField.h"

#include "haptics/base/InputError.h"
#include "haptics/propagation/PressureField.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

std::string whyInside(const Scatterer& thing, const Eigen::Matrix3Xd& places, const char* what)
{
    for (Eigen::Index i = 0; i < places.cols(); ++i)
        if (thing.isInside(places.col(i)))
            return fmt::format("{} {} at ({:.4f}, {:.4f}, {:.4f}) m is inside the body",
                               what,
                               i,
                               places(0, i),
                               places(1, i),
                               places(2, i));
    return {};
}

} // namespace

ScatteredField::ScatteredField(std::vector<std::shared_ptr<const Scatterer>> things,
                               TransducerArray array,
                               const Medium& medium,
                               int threads,
                               base::StopToken stop) :
    _things(std::move(things)),
    _array(std::move(array)),
    _medium(medium),
    _threads(threads),
    _stop(std::move(stop))
{
    for (const auto& thing : _things)
        if (const std::string why = whyInside(*thing, _array.positions, "transducer"); !why.empty())
            throw base::InputError(why);
}

void ScatteredField::setDrive(const Eigen::VectorXcf& q)
{
    if (q.size() == _q.size() && q == _q) return;
    _q.resize(0); // if it is stopped
    _strengths.assign(_things.size(), {});
    for (std::size_t k = 0; k < _things.size(); ++k)
    {
        const Scatterer& thing = *_things[k];
        const GmresReport report = thing.solve(
            incidentField(thing.places(), thing.normals(), _array, _medium, q, _threads, _stop),
            _strengths[k],
            _stop);
        _worst.iterations = std::max(_worst.iterations, report.iterations);
        _worst.residual = std::max(_worst.residual, report.residual);
    }
    _q = q;
}

Eigen::VectorXcd ScatteredField::free_Pa(const Eigen::Matrix3Xd& points) const
{
    return pressureAt(points, _array, _medium, _q, _threads, _stop).cast<std::complex<double>>();
}

Eigen::VectorXcd ScatteredField::scattered_Pa(const Eigen::Matrix3Xd& points) const
{
    Eigen::VectorXcd sum = Eigen::VectorXcd::Zero(points.cols());
    for (std::size_t k = 0; k < _things.size(); ++k)
        sum += _things[k]->scattered(points, _strengths[k], _threads);
    return sum;
}

Eigen::VectorXcd ScatteredField::beyond_Pa(const Eigen::Matrix3Xd& points,
                                           const TransducerArray& array) const
{
    Eigen::VectorXcd scattered = scattered_Pa(points);
    if (array.reflectors == _array.reflectors) return scattered;
    return scattered + free_Pa(points) -
           pressureAt(points, array, _medium, _q, _threads, _stop).cast<std::complex<double>>();
}

std::shared_ptr<const Eigen::MatrixXcf>
ScatteredField::optics_Pa(const Eigen::Matrix3Xd& points) const
{
    std::shared_ptr<Eigen::MatrixXcf> sum;
    for (const auto& thing : _things)
    {
        Eigen::MatrixXcf one = thing->optics(points, _array, _medium, _threads, _stop);
        if (one.size() == 0) continue;
        if (sum)
            *sum += one;
        else
            sum = std::make_shared<Eigen::MatrixXcf>(std::move(one));
    }
    return sum;
}

std::string ScatteredField::whyImpossible(const Eigen::Matrix3Xd& points) const
{
    for (const auto& thing : _things)
        if (std::string why = whyInside(*thing, points, "point"); !why.empty()) return why;
    return {};
}

bool ScatteredField::isInside(const Eigen::Vector3d& place) const
{
    return std::any_of(
        _things.begin(), _things.end(), [&](const auto& thing) { return thing->isInside(place); });
}

Eigen::Index ScatteredField::elements() const
{
    Eigen::Index sum = 0;
    for (const auto& thing : _things)
        sum += thing->places().cols();
    return sum;
}

} // namespace midair::haptics
