declare module "*.toml" {
  const texts: Record<string, string>;
  export default texts;
}
declare module "file:*" {
  const text: string;
  export default text;
}
