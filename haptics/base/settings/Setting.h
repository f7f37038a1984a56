#pragma once

#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace midair::base
{

/// Copies the base class \a Part of \a from to that of \a to.
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

/// A value of an enum: the word for users, the word stored in files, and the number.
struct Word
{
    std::string text;
    std::string stored;
    int value;
};

/// Pointer to the member of struct \a T that holds a setting; its type determines the setting's
/// kind. Structs with other member types specialise it, with a ValueText for each type.
template<typename T>
struct Kinds
{
    using Member = std::variant<bool T::*, int T::*, double T::*, Choice<T>, std::string T::*>;
};
template<typename T>
using Member = typename Kinds<T>::Member;

/// Range of a number: low .. high, inclusive; orZero: 0 is valid as well. NaN and infinity are
/// never valid.
struct Range
{
    double low = 0.0;
    double high = std::numeric_limits<double>::infinity();
    bool orZero = false;

    bool holds(double value) const;
    std::string text() const; ///< "0 or 0.001 .. 1", "at least 0"
};

/// Consequence of a changed value while a scene plays. Values may be joined by |.
enum Effect : unsigned
{
    NOTHING = 0, ///< for what plays; the player uses the value in the next frame
    SOLVE = 1,   ///< solves again, on the open device
    REOPEN = 2,  ///< opens array and device again
    MOVE = 4     ///< moves touchable objects in the array frame
};

/// Users of a field setting besides playing scenes. Values may be joined by |.
enum Use : unsigned
{
    PLAYED = 0, ///< none: only for playing scenes
    STILL = 1,  ///< programs that solve once for a scene at rest
    POINTS = 2  ///< programs that solve for several sets of points in turn
};

/// Facts about a setting, independent of the struct that holds it.
struct SettingFacts
{
    std::string name;        ///< as in options, tags and settings files: "fieldRate"
    std::string help;        ///< one-line description
    Range range{};           ///< for numbers
    std::string unit;        ///< for numbers; empty: none
    std::vector<Word> words; ///< for an enum
    std::string zero;        ///< for a double: the word for 0, "none"; empty: none
    std::vector<Word> named; ///< for an int: words for some values; files store the number

    std::string stored;              ///< name in scene files; empty: the name with a capital
    std::string variable;            ///< environment variable without "OSG_MIDAIR_"; empty: none
    bool isSafety = false;           ///< an invalid value silences the array
    unsigned effect = Effect::SOLVE; ///< of a changed value
    /// the played field depends on it, so baked fields are valid only for their value
    bool isIdentity = true;
    /// a text that names something outside the scene; in a file it is only a request, which the
    /// user must grant
    bool isWish = false;
    unsigned use = Use::STILL | Use::POINTS; ///< by others than playing scenes

    /// Returns the name in scene files: "FieldRate".
    std::string storedName() const;
    /// Returns the possible values of a number: "1 .. 40000 Hz", "1 .. 64, calm (1), smooth (8)".
    std::string numbers() const;
};

/// Row of a table: all facts about one value of a plain struct \a T. The member's initial value is
/// the default.
template<typename T>
struct Setting : SettingFacts
{
    Member<T> member{};
    /// Parses texts special to this setting; if empty or returning false, the text is parsed by
    /// kind.
    std::function<bool(T&, const std::string&)> parse;
    /// Returns the error in a text as a sentence that begins with the name, or an empty text; if
    /// empty, all texts are valid.
    std::function<std::string(const T&)> judge;

    /// Sets the value in \a object from text. Returns false on a syntax error. Accepts numbers out
    /// of range; see repair().
    bool assign(T& object, const std::string& text) const;
    /// Returns the valid input: "a number, 0 .. 1".
    std::string expected() const;
    /// If the value in \a object is out of range, resets it to the default, describes this in \a
    /// what and returns true.
    bool repair(T& object, std::string& what) const;

    /// Returns true if the value in \a object is in its range and passes judge(). Matrices, flags
    /// and other texts always do.
    bool holds(const T& object) const;
    /// Returns the error in the value of \a object, given as \a text, as a phrase: 'is "7", should
    /// be a number, 0 .. 1'; empty if it is valid.
    std::string problem(const T& object, const std::string& text) const;
    /// Returns the value in \a object; 0 if it is not a number.
    double number(const T& object) const;

    /// Returns the possible values: "1 .. 40000 Hz", "true, false", "surface, edges, vertices".
    std::string values() const;
    /// Returns the default, the value in \a defaults, as text: "1000"; empty for an empty text.
    std::string defaultText(const T& defaults = T()) const;
    /// Returns description, values and default in one line.
    std::string summary(const T& defaults = T()) const;
};

/// Choice for the enum member \a M of struct \a T or of a base class.
template<typename T, auto M>
constexpr Choice<T> choiceOf()
{
    return {[](const T& object) { return static_cast<int>(object.*M); },
            [](T& object, int value)
            { object.*M = static_cast<std::decay_t<decltype(object.*M)>>(value); }};
}

/// Returns true if \a a and \a b have equal values of \a member. Two NaN count as equal, so an
/// unchanged NaN is no change.
template<typename T>
bool isSame(const Member<T>& member, const T& a, const T& b);

} // namespace midair::base
