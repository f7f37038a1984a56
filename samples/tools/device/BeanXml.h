#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace midair::samples
{

/// Objects that Java's XMLEncoder has written (java.beans), as data: objects with named members and
/// lists. Elements say what a decoder would call; of these the few are followed that give values to
/// members (`property`, `getField` with `set` and `get`) and to lists (`add`), and none is called.
class BeanXml
{
public:
    /// Reads \a bytes, gzip or plain; at most \a mostBytes of XML. Throws base::InputError, which
    /// names \a source.
    BeanXml(const std::string& bytes, const std::string& source, std::size_t mostBytes);

    /// The object of class \a kind (without its package). Throws if there is none, or several.
    int only(const std::string& kind) const;
    /// Member \a name of an object; -1: it has none, or \a object is -1.
    int member(int object, const std::string& name) const;
    /// NaN if it isn't one.
    double number(int object) const;
    const std::vector<int>& list(int object) const;

private:
    struct Element
    {
        std::string tag;
        std::map<std::string, std::string> attributes;
        std::string text;
        std::vector<Element> children;

        const std::string& attribute(const char* name) const;
        bool isStatement() const { return tag == "void"; }
    };
    struct Object
    {
        std::string kind;
        double number = 0.0;
        std::map<std::string, int> members;
        std::vector<int> list;
    };
    class Parser;

    int make(const std::string& kind);
    int makeMember(int owner, const std::string& name);
    void remember(const Element& element, int object);
    int find(const std::string& id) const;
    int evaluate(const Element& element, int target);
    void evaluateAll(const Element& element, int target);
    int evaluateProperty(const Element& element, int target);
    void evaluateField(const Element& element);

    const std::string _source;
    std::vector<Object> _objects;
    std::map<std::string, int> _ids;
};

} // namespace midair::samples
