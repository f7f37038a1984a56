#include "engine-bridge/contact/ContactField.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Limits.h"
#include "haptics/base/text/Range.h"
#include "haptics/sequence/FieldOrder.h"

#include <algorithm>
#include <complex>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kMaskTurn = 0.9962;      ///< cosine of 5 degrees
constexpr double kFarthestFocus_m = 10.0; ///< from the array's origin; no focus is anywhere near
constexpr int kContactFoci = 1024;        ///< indices per contact, for identities
/// Far below the smallest change of a pressure that a fingertip tells, several percent: fields come
/// a thousand times a second, and a coarser one takes less time.
constexpr double kTolerance = 5e-3;

std::unique_ptr<haptics::HologramSolver> makeQuickSolver()
{
    haptics::SolverOptions options;
    options.rmsTolerance = kTolerance;
    return haptics::makeSolver(haptics::solverNames().front(), options);
}

} // namespace

bool ContactFieldOptions::isValid(std::string* error) const
{
    return base::RangeCheck("ContactFieldOptions: ")
        .within("maskCosine", maskCosine, -1.0, 1.0)
        .within("maskMotion_m", maskMotion_m, 0.0, 0.1)
        .passed(error);
}

ContactField::ContactField(const haptics::TransducerArray& array,
                           const haptics::Medium& medium,
                           const ContactFieldOptions& options) :
    _options(options),
    _medium(medium),
    _array(array),
    _masked(array),
    _isOn(static_cast<std::size_t>(array.size()), true),
    _driven(array.size()),
    _solver(makeQuickSolver())
{
    std::string error;
    if (!array.isValid(&error) || !medium.isValid(&error) || !options.isValid(&error))
        throw base::InputError(error);
}

bool ContactField::isMaskOf(const std::vector<Place>& places) const
{
    return std::equal(places.begin(),
                      places.end(),
                      _places.begin(),
                      _places.end(),
                      [&](const Place& a, const Place& b)
                      {
                          return a.contact == b.contact &&
                                 (a.centre - b.centre).norm() <= _options.maskMotion_m &&
                                 a.normal.dot(b.normal) >= kMaskTurn;
                      });
}

void ContactField::mask(const std::vector<ContactFocus>& foci)
{
    std::vector<Place> places;
    for (const ContactFocus& focus : foci)
        if (places.empty() || places.back().contact != focus.contact)
            places.push_back({focus.contact, focus.centre, focus.normal});
    if (!_options.mask || isMaskOf(places)) return;
    _isArrayKnown = false;
    _places = std::move(places);
    _masked.gain = _array.gain.size() > 0 ? _array.gain
                                          : Eigen::VectorXd(Eigen::VectorXd::Ones(_array.size()));
    _driven = 0;
    for (int i = 0; i < _array.size(); ++i)
    {
        const bool isOn =
            std::any_of(_places.begin(),
                        _places.end(),
                        [&](const Place& place)
                        {
                            const Vector3d way = _array.positions.col(i) - place.centre;
                            return way.dot(-place.normal) > _options.maskCosine * way.norm();
                        });
        _isOn[static_cast<std::size_t>(i)] = isOn;
        if (!isOn) _masked.gain[i] = 0.0;
        _driven += isOn ? 1 : 0;
    }
}

haptics::ControlPoints pointsOf(const std::vector<ContactFocus>& foci)
{
    haptics::ControlPoints points;
    const auto n = static_cast<Eigen::Index>(foci.size());
    points.positions.resize(3, n);
    points.normals.resize(3, n);
    points.targets.resize(n);
    points.absolute = true;
    for (Eigen::Index l = 0; l < n; ++l)
    {
        const ContactFocus& focus = foci[static_cast<std::size_t>(l)];
        points.positions.col(l) = focus.position;
        points.normals.col(l) = focus.normal;
        points.targets[l] = focus.pressure_Pa;
    }
    return points;
}

bool ContactField::solveFor(const std::vector<ContactFocus>& foci,
                            Eigen::VectorXcf& q,
                            std::string* error)
{
    haptics::ControlPoints points = pointsOf(foci);
    points.absolute = _options.absolute;
    for (const ContactFocus& focus : foci)
        points.identity.push_back(focus.contact * kContactFoci +
                                  static_cast<std::uint64_t>(focus.index));
    const haptics::TransducerArray* own = _isArrayKnown ? _solver->ownArray() : nullptr;
    const haptics::TransducerArray& array = _options.mask ? _masked : _array;
    _report = _solver->solve(points, own ? *own : array, _medium, q);
    _isArrayKnown = _report.stop != haptics::StopReason::REFUSED;
    if (_report.stop != haptics::StopReason::REFUSED)
    {
        for (int i = 0; i < _array.size() && _options.mask; ++i)
            if (!_isOn[static_cast<std::size_t>(i)]) q[i] = 0.0f;
        return true;
    }
    if (error) *error = _report.message;
    return false;
}

bool ContactField::solve(const std::vector<ContactFocus>& foci,
                         Eigen::VectorXcf& q,
                         std::string* error)
{
    q.setZero(_array.size());
    const auto isWrong = [](const ContactFocus& focus)
    {
        return !(focus.position.norm() <= kFarthestFocus_m) || !focus.centre.allFinite() ||
               !focus.normal.allFinite() || !(focus.pressure_Pa >= 0.0) ||
               !(focus.pressure_Pa <= base::kMostPressure_Pa);
    };
    std::string problem;
    if (foci.size() > static_cast<std::size_t>(kMostFoci))
        problem = "contacts have " + std::to_string(foci.size()) + " foci; at most " +
                  std::to_string(kMostFoci) + " are played at once";
    else if (std::any_of(foci.begin(), foci.end(), isWrong))
        problem = "a focus of a contact has a place farther than 10 m or a pressure outside 0 .. 1 "
                  "MPa, or a number that isn't finite";
    if (!problem.empty())
    {
        if (error) *error = problem;
        _last.resize(0);
        return false;
    }
    std::vector<ContactFocus> played;
    for (const ContactFocus& focus : foci)
        if (focus.pressure_Pa > 0.0) played.push_back(focus);
    _report = {};
    if (played.empty()) return true;
    mask(played);
    if (!solveFor(played, q, error))
    {
        q.setZero(_array.size());
        _last.resize(0);
        return false;
    }
    if (_last.size() == q.size()) haptics::alignField(q, _last, _array.drive);
    _last = q;
    return true;
}

} // namespace midair::bridge
