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

/// How contacts are rendered; isValid() names the first setting that is out of its range.
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
    /// the foci, with what is wanted there, for caps and figures; absolute, of the objects of the
    /// last update()
    haptics::ControlPoints foci;
    haptics::SolveReport report; ///< of the foci alone
    bool isFailed = false; ///< the foci could not be solved for: error says why, q is without them
    std::string error;
};

/// Makes the fields of objects that are felt where hands touch them: foci on the skin, added to
/// what is played of whole objects.
///
/// Frames come in by update(), fields go out by render(), a thousand a second or so. It has nothing
/// to do (isActive()) while no hand touches and nothing fades.
class ContactRenderer
{
public:
    /// Without an update() for this time contacts are silent: nobody knows where hands are.
    static constexpr double kStale_s = 0.25;

    /// Throws InputError for an array, medium or options that are not valid.
    ContactRenderer(const haptics::TransducerArray& array,
                    const haptics::Medium& medium,
                    const ContactRendererOptions& options = {});

    /// Returns true if any of \a objects is not played as a whole for good.
    bool concerns(const std::vector<HapticObject>& objects) const
    {
        return _shares.concerns(objects);
    }
    /// Takes a frame, at \a time_s of the steady clock. \a rest_s (>= 0): from the time of the
    /// hands' places to the sound, as far as nobody predicts. Sets the share of each of \a objects.
    void update(std::vector<HapticObject>& objects,
                const HandFrame& hands,
                double time_s,
                double rest_s);
    /// Ends all contacts.
    void clear();
    /// Says that no field is rendered now: view() has no foci until the next render().
    void pause();

    /// Returns true if fields are to be rendered at \a now_s: something is touched, or fades.
    bool isActive(double now_s) const;
    /// Renders the field for \a now_s, which goes on from that of the last call, on top of \a
    /// whole, what is played of whole objects without caps.
    RenderedField render(double now_s, const haptics::FieldSequence& whole);
    /// Keeps what the device made of the last render(), for view().
    void keep(double now_s, Eigen::VectorXcf played);

    ContactScene view() const;
    /// Returns the field of the last keep(); null: none is kept.
    std::shared_ptr<const TimedField> newest() const
    {
        return _recent.empty() ? nullptr : _recent.back();
    }
    /// What is wrong with hands and objects, a sentence each, as of the last update().
    std::vector<std::string> problems() const;

private:
    haptics::ControlPoints pointsWithObjects(const std::vector<ContactFocus>& foci) const;
    void addWhole(double now_s, const haptics::FieldSequence& whole, Eigen::VectorXcf& q) const;

    ContactRendererOptions _options;
    ContactTracker _tracker;
    ContactField _field;
    RenderShares _shares;
    std::unordered_map<std::uint64_t, int> _indices; ///< of the objects of the last update()
    std::vector<ContactFocus> _foci;                 ///< of the last render()
    double _updated_s = 0.0;
    double _rendered_s = 0.0;
    bool _isUpdated = false;
    bool _wasActive = false; ///< at the last render()
    std::deque<std::shared_ptr<const TimedField>> _recent;
};

} // namespace midair::bridge
