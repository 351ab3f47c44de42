//! The tables and keys that are read, from the source of their types.

use std::collections::BTreeMap;
use std::path::Path;

use syn::{Attribute, Expr, Field, Fields, GenericArgument, Item, Lit, Meta, PathArguments, Type};

/// Files with the types.
const SOURCES: [&str; 5] = [
    "io/problem/problem_file/schema/mod.rs",
    "io/problem/problem_file/schema/part.rs",
    "io/problem/problem_file/schema/contacts.rs",
    "io/problem/problem_file/schema/estimate.rs",
    "io/scenario/scenario_file/schema.rs",
];

/// What the value of a key may be.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Number,
    Integer,
    Text,
    Flag,
    /// `true`, `false` or a list of texts.
    FlagOrTexts,
    /// One of these texts.
    OneOf(Vec<String>),
    /// A list, of this many entries if that is fixed.
    List(Box<Value>, Option<usize>),
    /// Texts by any key.
    Texts,
    /// A table of this name.
    Table(String),
}

/// A key of a table.
#[derive(Clone, Debug)]
pub struct Key {
    pub name: String,
    pub value: Value,
    pub is_required: bool,
    /// Whether the value is a table, or a list of tables.
    pub is_table: bool,
    pub meaning: String,
    pub default: Option<String>,
    pub example: Option<String>,
}

/// All tables by the names of their types, with their keys in order.
pub struct Keys {
    tables: BTreeMap<String, Vec<Key>>,
}

impl Keys {
    /// Those that the readers have.
    pub fn read() -> Keys {
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let items: Vec<Item> = SOURCES
            .iter()
            .flat_map(|path| syn::parse_file(&std::fs::read_to_string(source.join(path)).unwrap()).unwrap().items)
            .collect();
        let mut choices = BTreeMap::new();
        for item in &items {
            if let Item::Enum(choice) = item {
                let names = choice
                    .variants
                    .iter()
                    .map(|variant| renamed(&variant.attrs).unwrap_or_else(|| snake_case(&variant.ident.to_string())));
                choices.insert(choice.ident.to_string(), names.collect::<Vec<String>>());
            }
        }
        let mut tables: BTreeMap<String, Vec<Key>> = BTreeMap::new();
        for item in &items {
            if let Item::Struct(table) = item
                && let Fields::Named(fields) = &table.fields
            {
                let keys = fields.named.iter().map(|field| key(field, &choices)).collect();
                tables.insert(table.ident.to_string(), keys);
            }
        }
        let of_log = tables["LogToml"].clone();
        let contacts = tables.get_mut("ContactsToml").unwrap();
        contacts.iter_mut().for_each(|key| *key = as_in_log(key, &of_log));
        Keys { tables }
    }

    /// The keys of a table.
    pub fn of(&self, table: &str) -> &[Key] {
        &self.tables[table]
    }

    /// All tables.
    pub fn tables(&self) -> impl Iterator<Item = (&String, &Vec<Key>)> {
        self.tables.iter()
    }
}

/// A key of a log without a comment of its own: its meaning is that of the key in `[log]`.
fn as_in_log(key: &Key, of_log: &[Key]) -> Key {
    match of_log.iter().find(|found| found.name == key.name && found.value == key.value) {
        Some(found) if key.meaning.is_empty() => Key { default: Some("that of `[log]`".to_owned()), ..found.clone() },
        _ => key.clone(),
    }
}

fn key(field: &Field, choices: &BTreeMap<String, Vec<String>>) -> Key {
    let (value, is_optional) = value(&field.ty, choices);
    let has_default = attributes(&field.attrs, "serde").any(|tokens| tokens == "default");
    let inner = if let Value::List(inner, None) = &value { inner } else { &value };
    let is_table = matches!(inner, Value::Table(name) if name != "PoseToml" && name != "RegionToml");
    let documented = documentation(&field.attrs);
    let (documented, example) = match documented.split_once(" Example: ") {
        Some((before, example)) => (before.to_owned(), Some(example.trim_matches('`').to_owned())),
        None => (documented, None),
    };
    let (meaning, default) = match documented.split_once(" Without it: ") {
        Some((meaning, default)) => (meaning.to_owned(), Some(default.trim_end_matches('.').to_owned())),
        None => (documented, None),
    };
    let (meaning, value) = match meaning.split_once(" One of: ") {
        Some((meaning, names)) => (meaning.to_owned(), one_of(names, value)),
        None => (meaning, value),
    };
    let is_required = !is_optional && !has_default;
    Key { name: field.ident.as_ref().unwrap().to_string(), value, is_required, is_table, meaning, default, example }
}

/// A text, or a list of texts, that must be among names written as "`a`, `b`.".
fn one_of(names: &str, value: Value) -> Value {
    let names = names.trim_end_matches('.').split(", ").map(|name| name.trim_matches('`').to_owned());
    match value {
        Value::Text => Value::OneOf(names.collect()),
        Value::List(inner, length) if *inner == Value::Text => {
            Value::List(Box::new(Value::OneOf(names.collect())), length)
        }
        other => panic!("{other:?} cannot be one of some names"),
    }
}

/// What a type stands for, and whether it may be left out.
fn value(ty: &Type, choices: &BTreeMap<String, Vec<String>>) -> (Value, bool) {
    if let Type::Array(array) = ty {
        let Expr::Lit(length) = &array.len else { panic!("a length that is no number") };
        let Lit::Int(length) = &length.lit else { panic!("a length that is no number") };
        return (Value::List(Box::new(value(&array.elem, choices).0), Some(length.base10_parse().unwrap())), false);
    }
    let Type::Path(path) = ty else { panic!("a type that is no path") };
    let last = path.path.segments.last().unwrap();
    let inner = || match &last.arguments {
        PathArguments::AngleBracketed(arguments) => match arguments.args.first() {
            Some(GenericArgument::Type(inner)) => value(inner, choices).0,
            _ => panic!("a generic argument that is no type"),
        },
        _ => panic!("no generic argument"),
    };
    let name = last.ident.to_string();
    let found = match name.as_str() {
        "Option" => return (inner(), true),
        "Spanned" => inner(),
        "Vec" => Value::List(Box::new(inner()), None),
        "BTreeMap" => Value::Texts,
        "Number" | "f64" => Value::Number,
        "i64" => Value::Integer,
        "Text" | "String" => Value::Text,
        "bool" => Value::Flag,
        "Value" => Value::FlagOrTexts,
        _ => choices.get(&name).cloned().map_or(Value::Table(name), Value::OneOf),
    };
    (found, false)
}

/// The arguments of attributes of this name, as text without blanks.
fn attributes<'a>(attributes: &'a [Attribute], name: &'a str) -> impl Iterator<Item = String> + 'a {
    attributes.iter().filter(move |attribute| attribute.path().is_ident(name)).filter_map(|attribute| {
        let Meta::List(list) = &attribute.meta else { return None };
        Some(list.tokens.to_string().replace(' ', ""))
    })
}

fn renamed(of: &[Attribute]) -> Option<String> {
    attributes(of, "serde").find_map(|tokens| Some(tokens.strip_prefix("rename=\"")?.trim_end_matches('"').to_owned()))
}

fn snake_case(name: &str) -> String {
    let lower = name.char_indices().flat_map(|(at, letter)| {
        let blank = (at > 0 && letter.is_uppercase()).then_some('_');
        blank.into_iter().chain(letter.to_lowercase())
    });
    lower.collect()
}

/// The comment of an item, in one line.
fn documentation(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter(|attribute| attribute.path().is_ident("doc")).map(|attribute| {
        let Meta::NameValue(line) = &attribute.meta else { panic!("a comment that is no text") };
        let Expr::Lit(line) = &line.value else { panic!("a comment that is no text") };
        let Lit::Str(line) = &line.lit else { panic!("a comment that is no text") };
        line.value().trim().to_owned()
    });
    lines.collect::<Vec<String>>().join(" ")
}
