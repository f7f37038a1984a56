#pragma once

#include "engine-bridge/contact/ContactField.h"
#include "engine-bridge/contact/ContactTracker.h"
#include "engine-bridge/rendering/ContactView.h"
#include "engine-bridge/rendering/RenderShares.h"
#include "haptics/sequence/FieldSequence.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

namespace midair::bridge
{

/// Options for rendering contacts; isValid() names the first setting that is out of its range.
struct ContactRendererOptions
{
    ContactTrackerOptions tracker;
    ContactFieldOptions field;
    RenderSharesOptions shares;

    bool isValid(std::string* error = nullptr) const;
};

/// One field of contacts.
struct RenderedField
{
    Eigen::VectorXcf q; ///< m activations, |q_i| <= 1
    /// the foci with their targets, for caps and figures; absolute; object indices of the last
    /// update()
    haptics::ControlPoints foci;
    haptics::SolveReport report; ///< for the foci only
    bool isFailed = false;       ///< solving the foci failed, see error; q is without them
    std::string error;
};

/// Makes the fields of objects rendered by contacts: foci on the skin, added to the field of whole
/// objects.
///
/// update() takes frames, render() makes fields, about a thousand a second. It is idle (isActive())
/// while no hand touches and nothing fades.
class ContactRenderer
{
public:
    /// Without an update() for this time contacts are silent, because the hands' positions are
    /// unknown.
    static constexpr double kStale_s = 0.25;

    /// Throws InputError for an array, medium or options that are not valid.
    ContactRenderer(const haptics::TransducerArray& array,
                    const haptics::Medium& medium,
                    const ContactRendererOptions& options = {});

    /// Returns true if any of \a objects is not always played as a whole.
    bool concerns(const std::vector<HapticObject>& objects) const
    {
        return _shares.concerns(objects);
    }
    /// Takes a frame at \a time_s of the steady clock. \a rest_s (>= 0): from the time of the
    /// hands' positions to the sound, as far as it isn't predicted. Sets the share of each of \a
    /// objects.
    void update(std::vector<HapticObject>& objects,
                const HandFrame& hands,
                double time_s,
                double rest_s);
    /// Ends all contacts.
    void clear();
    /// No field is rendered for now: view() has no foci until the next render().
    void pause();

    /// Returns true if fields have to be rendered at \a now_s: an object is touched, or fades.
    bool isActive(double now_s) const;
    /// Renders the field for \a now_s, continuing the last call's, on top of \a whole, the field of
    /// whole objects without caps. No focus is solved for more than \a most_Pa (0: no limit), so
    /// that one that exceeds a cap doesn't weaken the others.
    RenderedField render(double now_s, const haptics::FieldSequence& whole, double most_Pa = 0.0);
    /// Stores the device's version of the last render(), for view().
    void keep(double now_s, Eigen::VectorXcf played);

    ContactScene view() const;
    /// Returns the field of the last keep(); null: none.
    std::shared_ptr<const TimedField> newest() const
    {
        return _recent.empty() ? nullptr : _recent.back();
    }
    /// Problems of hands and objects, one sentence each, in the last update().
    std::vector<std::string> problems() const;

private:
    haptics::ControlPoints pointsWithObjects(const std::vector<ContactFocus>& foci) const;
    void addWhole(double now_s, const haptics::FieldSequence& whole, Eigen::VectorXcf& q) const;

    ContactRendererOptions _options;
    ContactTracker _tracker;
    ContactField _field;
    RenderShares _shares;
    std::unordered_map<std::uint64_t, int> _indices; ///< of the objects of the last update()
    std::vector<ContactFocus> _foci;                 ///< from the last render()
    double _updated_s = 0.0;
    double _rendered_s = 0.0;
    bool _isUpdated = false;
    bool _wasActive = false; ///< in the last render()
    std::deque<std::shared_ptr<const TimedField>> _recent;
};

} // namespace midair::bridge
