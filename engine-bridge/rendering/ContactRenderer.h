#pragma once

#include "engine-bridge/contact/ContactField.h"
#include "engine-bridge/contact/ContactTracker.h"
#include "engine-bridge/rendering/ContactView.h"
#include "engine-bridge/rendering/RenderShares.h"
#include "engine-bridge/sensations/Precedence.h"
#include "engine-bridge/sensations/SensationRenderer.h"
#include "haptics/probe/Feeling.h"
#include "haptics/sequence/FieldSequence.h"

#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
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

/// Makes the fields of objects rendered by contacts, foci on the skin, and of sensations, added to
/// the field of whole objects. A sensation of a higher priority than theirs fades contacts and
/// whole objects out, and a contact of a higher one fades sensations out.
///
/// update() takes frames, render() makes fields, about a thousand a second. It is idle (isActive())
/// while no hand touches, no sensation plays and nothing fades.
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
    /// Ends all contacts and sensations.
    void clear();
    /// Ends all contacts. Sensations wait, and go on with the next render().
    void endContacts();
    /// No field is rendered for now: view() has no foci until the next render().
    void pause();

    /// Returns true if fields have to be rendered at \a now_s: an object is touched, a sensation
    /// plays, or one of them fades.
    bool isActive(double now_s) const;
    /// Renders the field for \a now_s, continuing the last call's, on top of \a whole, the field of
    /// whole objects without caps. No focus is solved for more than \a most_Pa (0: no limit), so
    /// that one that exceeds a cap doesn't weaken the others. \a rate_Hz: of fields, for
    /// sensations.
    RenderedField render(double now_s,
                         const haptics::FieldSequence& whole,
                         double most_Pa = 0.0,
                         double rate_Hz = 0.0);
    /// Continues the last render() to \a now_s without a field: the device plays \a turn by itself.
    void follow(double now_s, double most_Pa, double rate_Hz, const haptics::StoredTurn& turn)
    {
        advance(now_s, most_Pa, rate_Hz, &turn);
    }
    /// Returns what follows the last render() for ever, if sensations alone are played, and nothing
    /// of them changes; most_Pa as there.
    std::optional<SteadyTurn> steady(double most_Pa) const;
    /// Renders the fields of \a turn, one after the other: the field and its foci, as render()
    /// does. Stops after one that fails.
    std::vector<RenderedField> render(const SteadyTurn& steady, const haptics::StoredTurn& turn);
    /// How the skin feels the last render().
    haptics::PlayedAs playedAs() const;
    /// Takes the factor, 0 .. 1, by which caps have lowered the last render().
    void noteCap(double factor);
    /// Continues the sensations of \a before, whose options were others.
    void continueSensations(ContactRenderer& before)
    {
        _sensations.continueFrom(before._sensations);
    }
    /// Goes on with the reflectors of \a array, which is the same otherwise.
    void setReflectors(const haptics::TransducerArray& array)
    {
        _field.setReflectors(array.reflectors);
        _sensations.setArray(array);
    }
    /// Stores the device's version of the last render(), for view().
    void keep(double now_s, Eigen::VectorXcf played);
    /// The same for fields that the device repeats from \a now_s on: as if they had just been
    /// played.
    void keepTurn(double now_s, double rate_Hz, std::vector<Eigen::VectorXcf> played);

    ContactScene view() const;
    double whole() const; ///< see ContactScene::whole
    /// Returns the field of the last keep(); null: none.
    std::shared_ptr<const TimedField> newest() const
    {
        return _recent.empty() ? nullptr : _recent.back();
    }
    /// Problems of hands and objects, one sentence each, in the last update().
    std::vector<std::string> problems() const;
    /// Problems of sensations in the last render().
    std::vector<base::Message> sensationProblems() const { return _sensations.problems(); }

private:
    /// What update() has found out about an object that isn't always whole.
    struct Known
    {
        int index = 0;
        int priority = 0;
        bool isSensation = false;
    };

    static constexpr int kNone = std::numeric_limits<int>::min(); ///< the priority of nothing

    /// Factors by priority, as they fade.
    struct Levels
    {
        Precedence others;     ///< contacts and whole objects, below sensations
        Precedence sensations; ///< below each other and contacts
        int wholePriority = 0; ///< the highest of objects that are played as a whole
        double whole = 1.0;    ///< on the field of whole objects, in the last render()
    };

    haptics::ControlPoints pointsWithObjects(const std::vector<ContactFocus>& foci) const;
    void addWhole(double now_s, const haptics::FieldSequence& whole, Eigen::VectorXcf& q) const;
    bool presses(const Contact& contact) const;
    void advance(double now_s, double most_Pa, double rate_Hz, const haptics::StoredTurn* turn);
    RenderedField solved(const std::vector<ContactFocus>& foci, double most_Pa);
    void settlePrecedence(double dt_s);
    bool isWholePlayed() const { return _levels.whole > 0.0 && _levels.wholePriority > kNone; }
    bool isOfSensation(const ContactFocus& focus) const;
    bool areOfSensations() const; ///< all foci of the last render()
    void addContacts(double now_s);

    ContactRendererOptions _options;
    ContactTracker _tracker;
    ContactField _field;
    RenderShares _shares;
    SensationRenderer _sensations;
    Levels _levels;
    std::unordered_map<std::uint64_t, Known> _objects; ///< of the last update()
    std::vector<ContactFocus> _foci;                   ///< from the last render()
    double _updated_s = 0.0;
    double _rendered_s = 0.0;
    double _step_s = 0.0; ///< of the last render()
    bool _isUpdated = false;
    bool _wasActive = false; ///< in the last render()
    std::deque<std::shared_ptr<const TimedField>> _recent;
};

} // namespace midair::bridge
