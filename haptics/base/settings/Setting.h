#pragma once

#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace midair::base
{

/// Replaces what \a to has of its base class \a Part by that of \a from.
template<class Part, class To, class From>
void assignPart(To& to, const From& from)
{
    static_cast<Part&>(to) = static_cast<const Part&>(from);
}

/// Access to a member of enum type in a struct \a T.
template<typename T>
struct Choice
{
    int (*get)(const T&);
    void (*set)(T&, int);
};

/// One value of an enum: the word that people write, the word that files store, and the number.
struct Word
{
    std::string text;
    std::string stored;
    int value;
};

/// Pointer to the member of a struct \a T that holds a setting, and so its kind. Structs with
/// members of further types have a specialisation, and a ValueText for each of those.
template<typename T>
struct Kinds
{
    using Member = std::variant<bool T::*, int T::*, double T::*, Choice<T>, std::string T::*>;
};
template<typename T>
using Member = typename Kinds<T>::Member;

/// Range of a number: low .. high, ends included; orZero: 0 is valid as well. NaN and infinity
/// never are.
struct Range
{
    double low = 0.0;
    double high = std::numeric_limits<double>::infinity();
    bool orZero = false;

    bool holds(double value) const;
    std::string text() const; ///< "0 or 0.001 .. 1", "at least 0"
};

/// What follows when a value changes while a scene is played. Several may be joined by |.
enum Effect : unsigned
{
    NOTHING = 0, ///< in what plays: whoever plays acts on it in the next frame
    SOLVE = 1,   ///< fields are solved again, on the device that is open
    REOPEN = 2,  ///< array and device are opened anew
    MOVE = 4     ///< what is felt is elsewhere in the array's frame
};

/// Who has a use for a setting of a field besides scenes that play. Several may be joined by |.
enum Use : unsigned
{
    PLAYED = 0, ///< nobody: it is of what goes on while a scene plays
    STILL = 1,  ///< whoever solves for a scene at rest, once
    POINTS = 2  ///< whoever solves for one set of points after the other
};

/// What a row says of a value, whatever struct holds it.
struct SettingFacts
{
    std::string name;        ///< as in options, tags and settings files: "fieldRate"
    std::string help;        ///< one line that says what it does
    Range range{};           ///< for numbers
    std::string unit;        ///< for numbers; empty: none
    std::vector<Word> words; ///< for an enum
    std::string zero;        ///< for a double: the word that says 0, "none"; empty: there is none

    std::string stored;    ///< name in scene files; empty: the name with a capital
    std::string variable;  ///< name of the environment variable after "OSG_MIDAIR_"; empty: none
    bool isSafety = false; ///< a value that isn't understood silences the array
    unsigned effect = Effect::SOLVE; ///< of a change
    /// what is played of a frame depends on it, so that a baked field is one of its value
    bool isIdentity = true;
    /// a text that names what is outside of the scene: where a file gives it, it is a wish, which
    /// needs the user's grant
    bool isWish = false;
    unsigned use = Use::STILL | Use::POINTS; ///< by others than scenes that play

    /// Returns the name in scene files: "FieldRate".
    std::string storedName() const;
    /// Returns the possible values of a number: "1 .. 40000 Hz".
    std::string numbers() const { return range.text() + (unit.empty() ? "" : " " + unit); }
};

/// A row of a table: all that is known about one value of a plain struct \a T. The default is the
/// initial value of the member.
template<typename T>
struct Setting : SettingFacts
{
    Member<T> member{};
    /// Parses texts that only this setting has; empty, or false returned: parsed by its kind.
    std::function<bool(T&, const std::string&)> parse;
    /// Returns what is wrong with a text, a sentence that begins with the name, or an empty text;
    /// empty: any will do.
    std::function<std::string(const T&)> judge;

    /// Sets the value in \a object from text. Returns false if it isn't understood. Numbers out of
    /// range are accepted; see repair().
    bool assign(T& object, const std::string& text) const;
    /// Returns what assign() understands: "a number, 0 .. 1".
    std::string expected() const;
    /// If the value in \a object is out of range, resets it to the default, explains this in \a
    /// what and returns true.
    bool repair(T& object, std::string& what) const;

    /// Returns true if the value in \a object is in its range, or as what judges it wants it.
    /// Matrices, flags and other texts always are.
    bool holds(const T& object) const;
    /// Returns what is wrong with the value in \a object, which is what \a text says, as a phrase:
    /// 'is "7", should be a number, 0 .. 1'; empty: it holds.
    std::string problem(const T& object, const std::string& text) const;
    /// Returns the value in \a object; 0 if it is no number.
    double number(const T& object) const;

    /// Returns the possible values: "1 .. 40000 Hz", "true, false", "surface, edges, vertices".
    std::string values() const;
    /// Returns the default, which is the value in \a defaults, as text, "1000"; empty where it is
    /// an empty text.
    std::string defaultText(const T& defaults = T()) const;
    /// Returns help, values and default in one line.
    std::string summary(const T& defaults = T()) const;
};

/// Choice for the enum member that \a M points to, of a struct \a T or of one that it inherits
/// from.
template<typename T, auto M>
constexpr Choice<T> choiceOf()
{
    return {[](const T& object) { return static_cast<int>(object.*M); },
            [](T& object, int value)
            { object.*M = static_cast<std::decay_t<decltype(object.*M)>>(value); }};
}

/// Returns true if the values of \a member are equal in \a a and \a b. Two NaN count as equal, so
/// that a NaN that stays is no change.
template<typename T>
bool isSame(const Member<T>& member, const T& a, const T& b);

} // namespace midair::base
